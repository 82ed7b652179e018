# @{ module }@: Intel Quartus Prime, all ports but the clock virtual, synthesis to timing. Not run by hwgen.
# Run in an empty directory outside of the bundle: quartus_sh -t BUNDLE/syn/@{ module }@.quartus.tcl [DEVICE]
load_package flow
set device [expr {[llength $quartus(args)] > 0 ? [lindex $quartus(args) 0] : "@{ part }@"}]
set root [file normalize [file join [file dirname [info script]] ..]]
project_new @{ module }@ -overwrite -part $device
set_global_assignment -name TOP_LEVEL_ENTITY @{ module }@
foreach file {
@% for file in sources %@  @{ file }@
@% endfor %@} {
  set_global_assignment -name VERILOG_FILE $root/$file
}
set_global_assignment -name SDC_FILE $root/constraints/@{ module }@.sdc
set_instance_assignment -name VIRTUAL_PIN ON -to *
set_instance_assignment -name VIRTUAL_PIN OFF -to aclk
execute_flow -compile
project_close
