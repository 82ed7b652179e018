# pair: Gowin EDA, synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: gw_sh BUNDLE/syn/pair.gowin.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
set_device GW2A-LV18PG256C8/I7
add_file -type verilog $root/rtl/pair.v
add_file -type verilog $root/rtl/pair__hwg_accumulator.v
add_file -type verilog $root/rtl/pair__hwg_admit.v
add_file -type verilog $root/rtl/pair__hwg_beats.v
add_file -type verilog $root/rtl/pair__hwg_count.v
add_file -type verilog $root/rtl/pair__hwg_delay.v
add_file -type verilog $root/rtl/pair__hwg_drain.v
add_file -type verilog $root/rtl/pair__hwg_egress.v
add_file -type verilog $root/rtl/pair__hwg_gather.v
add_file -type verilog $root/rtl/pair__hwg_group.v
add_file -type verilog $root/rtl/pair__hwg_hold.v
add_file -type verilog $root/rtl/pair__hwg_ingress.v
add_file -type verilog $root/rtl/pair__hwg_mul.v
add_file -type verilog $root/rtl/pair__hwg_pwl.v
add_file -type verilog $root/rtl/pair__hwg_queue.v
add_file -type verilog $root/rtl/pair__hwg_replay.v
add_file -type verilog $root/rtl/pair__hwg_requant.v
add_file -type verilog $root/rtl/pair__hwg_slice.v
add_file -type verilog $root/rtl/pair__hwg_tree_level.v
add_file -type verilog $root/rtl/pair__mlp.v
add_file -type verilog $root/rtl/pair__shared_l0.v
add_file -type verilog $root/rtl/pair__shared_l0_bias.v
add_file -type verilog $root/rtl/pair__shared_l0_pe.v
add_file -type verilog $root/rtl/pair__shared_l0_w0.v
add_file -type verilog $root/rtl/pair__size_l0.v
add_file -type verilog $root/rtl/pair__size_l0_bias.v
add_file -type verilog $root/rtl/pair__size_l0_pe.v
add_file -type verilog $root/rtl/pair__size_l0_w0.v
add_file -type verilog $root/rtl/pair__size_l1.v
add_file -type verilog $root/rtl/pair__size_l1_bias.v
add_file -type verilog $root/rtl/pair__size_l1_pe.v
add_file -type verilog $root/rtl/pair__size_l1_w0.v
add_file -type verilog $root/rtl/pair__tanh13.v
add_file -type verilog $root/rtl/pair__turn_l0.v
add_file -type verilog $root/rtl/pair__turn_l0_bias.v
add_file -type verilog $root/rtl/pair__turn_l0_pe.v
add_file -type verilog $root/rtl/pair__turn_l0_w0.v
add_file -type verilog $root/rtl/pair__turn_l0_w1.v
add_file -type verilog $root/rtl/pair__turn_l0_w2.v
add_file -type verilog $root/rtl/pair__turn_l1.v
add_file -type verilog $root/rtl/pair__turn_l1_bias.v
add_file -type verilog $root/rtl/pair__turn_l1_pe.v
add_file -type verilog $root/rtl/pair__turn_l1_w0.v
add_file -type verilog $root/rtl/pair__turn_out.v
add_file -type verilog $root/rtl/pair__turn_out_bias.v
add_file -type verilog $root/rtl/pair__turn_out_pe.v
add_file -type verilog $root/rtl/pair__turn_out_w0.v
add_file -type sdc $root/constraints/pair.sdc
set_option -synthesis_tool gowinsynthesis
set_option -top_module pair
set_option -output_base_name pair
set_option -verilog_std v2001
run all
