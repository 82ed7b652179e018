# @{ module }@: Intel Quartus Prime, all ports virtual, synthesis to timing. Not run by hwgen.
# Run in the bundle's directory: quartus_sh -t syn/@{ module }@.quartus.tcl [DEVICE]
load_package flow
set device [expr {[llength $quartus(args)] > 0 ? [lindex $quartus(args) 0] : "5CSEMA5F31C6"}]
set root [pwd]
file mkdir build-quartus
cd build-quartus
project_new @{ module }@ -overwrite
set_global_assignment -name DEVICE $device
set_global_assignment -name TOP_LEVEL_ENTITY @{ module }@
foreach file {
@% for file in sources %@  @{ file }@
@% endfor %@} {
  set_global_assignment -name VERILOG_FILE $root/$file
}
set_global_assignment -name SDC_FILE $root/constraints/@{ module }@.sdc
set_instance_assignment -name VIRTUAL_PIN ON -to *
execute_flow -compile
project_close
