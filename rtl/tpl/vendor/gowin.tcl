# @{ module }@: Gowin EDA, synthesis to routes. Not run by hwgen.
# Run in the bundle's directory: gw_sh syn/@{ module }@.gowin.tcl
set_device GW2A-LV18PG256C8/I7
@% for file in sources %@add_file -type verilog @{ file }@
@% endfor %@add_file -type sdc constraints/@{ module }@.sdc
set_option -synthesis_tool gowinsynthesis
set_option -top_module @{ module }@
set_option -output_base_name @{ module }@
set_option -verilog_std v2001
run all
