# @{ module }@: Gowin EDA, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: gw_sh BUNDLE/syn/@{ module }@.gowin.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
set_device @{ part }@
@% for file in sources %@add_file -type verilog $root/@{ file }@
@% endfor %@add_file -type sdc $root/constraints/@{ module }@.sdc
set_option -synthesis_tool gowinsynthesis
set_option -top_module @{ module }@
set_option -output_base_name @{ module }@
set_option -verilog_std v2001
run all
