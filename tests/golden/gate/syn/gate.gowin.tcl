# gate: Gowin EDA, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: gw_sh BUNDLE/syn/gate.gowin.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
set_device GW2A-LV18PG256C8/I7
add_file -type verilog $root/rtl/gate.v
add_file -type verilog $root/rtl/gate_mlp.v
add_file -type verilog $root/rtl/gate_net_l0.v
add_file -type verilog $root/rtl/gate_net_l0_bias.v
add_file -type verilog $root/rtl/gate_net_l0_pe.v
add_file -type verilog $root/rtl/gate_net_l0_w0.v
add_file -type verilog $root/rtl/gate_net_l1.v
add_file -type verilog $root/rtl/gate_net_l1_bias.v
add_file -type verilog $root/rtl/gate_net_l1_pe.v
add_file -type verilog $root/rtl/gate_net_l1_w0.v
add_file -type verilog $root/rtl/gate_net_l1_w1.v
add_file -type verilog $root/rtl/gate_tanh11.v
add_file -type verilog $root/rtl/hwg_accumulator.v
add_file -type verilog $root/rtl/hwg_admit.v
add_file -type verilog $root/rtl/hwg_beats.v
add_file -type verilog $root/rtl/hwg_count.v
add_file -type verilog $root/rtl/hwg_delay.v
add_file -type verilog $root/rtl/hwg_drain.v
add_file -type verilog $root/rtl/hwg_egress.v
add_file -type verilog $root/rtl/hwg_gather.v
add_file -type verilog $root/rtl/hwg_group.v
add_file -type verilog $root/rtl/hwg_ingress.v
add_file -type verilog $root/rtl/hwg_mul.v
add_file -type verilog $root/rtl/hwg_pwl.v
add_file -type verilog $root/rtl/hwg_queue.v
add_file -type verilog $root/rtl/hwg_replay.v
add_file -type verilog $root/rtl/hwg_requant.v
add_file -type verilog $root/rtl/hwg_slice.v
add_file -type verilog $root/rtl/hwg_tree_level.v
add_file -type sdc $root/constraints/gate.sdc
set_option -synthesis_tool gowinsynthesis
set_option -top_module gate
set_option -output_base_name gate
set_option -verilog_std v2001
run all
