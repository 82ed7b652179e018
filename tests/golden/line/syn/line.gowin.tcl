# line: Gowin EDA, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: gw_sh BUNDLE/syn/line.gowin.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
set_device GW2A-LV18PG256C8/I7
add_file -type verilog $root/rtl/line.v
add_file -type verilog $root/rtl/line__hwg_admit.v
add_file -type verilog $root/rtl/line__hwg_count.v
add_file -type verilog $root/rtl/line__hwg_delay.v
add_file -type verilog $root/rtl/line__hwg_egress.v
add_file -type verilog $root/rtl/line__hwg_gather.v
add_file -type verilog $root/rtl/line__hwg_ingress.v
add_file -type verilog $root/rtl/line__hwg_mul.v
add_file -type verilog $root/rtl/line__hwg_queue.v
add_file -type verilog $root/rtl/line__hwg_replay.v
add_file -type verilog $root/rtl/line__hwg_requant.v
add_file -type verilog $root/rtl/line__hwg_slice.v
add_file -type verilog $root/rtl/line__mlp.v
add_file -type verilog $root/rtl/line__net_l0.v
add_file -type verilog $root/rtl/line__net_l0_bias.v
add_file -type verilog $root/rtl/line__net_l0_pe.v
add_file -type verilog $root/rtl/line__net_l0_w0.v
add_file -type sdc $root/constraints/line.sdc
set_option -synthesis_tool gowinsynthesis
set_option -top_module line
set_option -output_base_name line
set_option -verilog_std v2001
run all
