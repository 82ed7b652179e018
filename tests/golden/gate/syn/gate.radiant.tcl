# gate: Lattice Radiant (Nexus), synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: radiantc BUNDLE/syn/gate.radiant.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
prj_create -name gate -impl impl_1 -dev LIFCL-40-7BG400I -performance 7_High-Performance_1.0V -synthesis synplify
foreach file {
  rtl/gate.v
  rtl/gate_mlp.v
  rtl/gate_net_l0.v
  rtl/gate_net_l0_bias.v
  rtl/gate_net_l0_pe.v
  rtl/gate_net_l0_w0.v
  rtl/gate_net_l1.v
  rtl/gate_net_l1_bias.v
  rtl/gate_net_l1_pe.v
  rtl/gate_net_l1_w0.v
  rtl/gate_net_l1_w1.v
  rtl/gate_tanh11.v
  rtl/hwg_accumulator.v
  rtl/hwg_admit.v
  rtl/hwg_beats.v
  rtl/hwg_count.v
  rtl/hwg_delay.v
  rtl/hwg_drain.v
  rtl/hwg_egress.v
  rtl/hwg_gather.v
  rtl/hwg_group.v
  rtl/hwg_ingress.v
  rtl/hwg_mul.v
  rtl/hwg_pwl.v
  rtl/hwg_queue.v
  rtl/hwg_replay.v
  rtl/hwg_requant.v
  rtl/hwg_slice.v
  rtl/hwg_tree_level.v
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
