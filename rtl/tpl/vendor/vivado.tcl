# @{ module }@: AMD Vivado, out of context, synthesis to routes. Not run by hwgen.
# Run in the bundle's directory: vivado -mode batch -source syn/@{ module }@.vivado.tcl [-tclargs PART]
set part [expr {$argc > 0 ? [lindex $argv 0] : "xc7a35tcpg236-1"}]
read_verilog [list \
@% for file in sources %@  @{ file }@ \
@% endfor %@]
read_xdc -unmanaged constraints/@{ module }@.sdc
synth_design -top @{ module }@ -part $part -mode out_of_context
opt_design
place_design
phys_opt_design
route_design
file mkdir build-vivado
report_utilization -hierarchical -file build-vivado/utilization.txt
report_timing_summary -file build-vivado/timing.txt
write_checkpoint -force build-vivado/@{ module }@.dcp
