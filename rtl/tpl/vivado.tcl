# @{ module }@: AMD Vivado, out of context, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: vivado -mode batch -source BUNDLE/syn/@{ module }@.vivado.tcl [-tclargs PART]
set root [file normalize [file join [file dirname [info script]] ..]]
set part [expr {$argc > 0 ? [lindex $argv 0] : "@{ part }@"}]
foreach file {
@% for file in sources %@  @{ file }@
@% endfor %@} {
  read_verilog $root/$file
}
read_xdc -unmanaged $root/constraints/@{ module }@.sdc
synth_design -top @{ module }@ -part $part -mode out_of_context
opt_design
place_design
phys_opt_design
route_design
report_utilization -hierarchical -file utilization.txt
report_timing_summary -file timing.txt
write_checkpoint -force @{ module }@.dcp
