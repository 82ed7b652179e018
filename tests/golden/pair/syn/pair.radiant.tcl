# pair: Lattice Radiant (Nexus), synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: radiantc BUNDLE/syn/pair.radiant.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
prj_create -name pair -impl impl_1 -dev LIFCL-40-7BG400I -performance 7_High-Performance_1.0V -synthesis synplify
foreach file {
  rtl/pair.v
  rtl/pair__hwg_accumulator.v
  rtl/pair__hwg_admit.v
  rtl/pair__hwg_beats.v
  rtl/pair__hwg_count.v
  rtl/pair__hwg_delay.v
  rtl/pair__hwg_drain.v
  rtl/pair__hwg_egress.v
  rtl/pair__hwg_gather.v
  rtl/pair__hwg_group.v
  rtl/pair__hwg_hold.v
  rtl/pair__hwg_ingress.v
  rtl/pair__hwg_mul.v
  rtl/pair__hwg_pwl.v
  rtl/pair__hwg_queue.v
  rtl/pair__hwg_replay.v
  rtl/pair__hwg_requant.v
  rtl/pair__hwg_slice.v
  rtl/pair__hwg_tree_level.v
  rtl/pair__mlp.v
  rtl/pair__shared_l0.v
  rtl/pair__shared_l0_bias.v
  rtl/pair__shared_l0_pe.v
  rtl/pair__shared_l0_w0.v
  rtl/pair__size_l0.v
  rtl/pair__size_l0_bias.v
  rtl/pair__size_l0_pe.v
  rtl/pair__size_l0_w0.v
  rtl/pair__size_l1.v
  rtl/pair__size_l1_bias.v
  rtl/pair__size_l1_pe.v
  rtl/pair__size_l1_w0.v
  rtl/pair__tanh13.v
  rtl/pair__turn_l0.v
  rtl/pair__turn_l0_bias.v
  rtl/pair__turn_l0_pe.v
  rtl/pair__turn_l0_w0.v
  rtl/pair__turn_l0_w1.v
  rtl/pair__turn_l0_w2.v
  rtl/pair__turn_l1.v
  rtl/pair__turn_l1_bias.v
  rtl/pair__turn_l1_pe.v
  rtl/pair__turn_l1_w0.v
  rtl/pair__turn_out.v
  rtl/pair__turn_out_bias.v
  rtl/pair__turn_out_pe.v
  rtl/pair__turn_out_w0.v
} {
  prj_add_source $root/$file
}
prj_add_source $root/constraints/pair.sdc
prj_set_impl_opt -impl impl_1 top pair
prj_save
prj_run Synthesis -impl impl_1
prj_run Map -impl impl_1
prj_run PAR -impl impl_1
prj_save
prj_close
