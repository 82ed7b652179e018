# gate: Lattice Radiant (Nexus), synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: radiantc BUNDLE/syn/gate.radiant.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
prj_create -name gate -impl impl_1 -dev LIFCL-40-7BG400I -performance 7_High-Performance_1.0V -synthesis synplify
foreach file {
  rtl/gate.v
  rtl/gate__hwg_accumulator.v
  rtl/gate__hwg_admit.v
  rtl/gate__hwg_beats.v
  rtl/gate__hwg_count.v
  rtl/gate__hwg_delay.v
  rtl/gate__hwg_drain.v
  rtl/gate__hwg_egress.v
  rtl/gate__hwg_gather.v
  rtl/gate__hwg_group.v
  rtl/gate__hwg_ingress.v
  rtl/gate__hwg_mul.v
  rtl/gate__hwg_pwl.v
  rtl/gate__hwg_queue.v
  rtl/gate__hwg_replay.v
  rtl/gate__hwg_requant.v
  rtl/gate__hwg_slice.v
  rtl/gate__hwg_tree_level.v
  rtl/gate__mlp.v
  rtl/gate__net_l0.v
  rtl/gate__net_l0_bias.v
  rtl/gate__net_l0_pe.v
  rtl/gate__net_l0_w0.v
  rtl/gate__net_l1.v
  rtl/gate__net_l1_bias.v
  rtl/gate__net_l1_pe.v
  rtl/gate__net_l1_w0.v
  rtl/gate__net_l1_w1.v
  rtl/gate__tanh11.v
} {
  prj_add_source $root/$file
}
prj_add_source $root/constraints/gate.sdc
prj_set_impl_opt -impl impl_1 top gate
prj_save
prj_run Synthesis -impl impl_1
prj_run Map -impl impl_1
prj_run PAR -impl impl_1
prj_save
prj_close
