# line: Lattice Radiant (Nexus), synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: radiantc BUNDLE/syn/line.radiant.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
prj_create -name line -impl impl_1 -dev LIFCL-40-7BG400I -performance 7_High-Performance_1.0V -synthesis synplify
foreach file {
  rtl/line.v
  rtl/line__hwg_admit.v
  rtl/line__hwg_count.v
  rtl/line__hwg_delay.v
  rtl/line__hwg_egress.v
  rtl/line__hwg_gather.v
  rtl/line__hwg_ingress.v
  rtl/line__hwg_mul.v
  rtl/line__hwg_queue.v
  rtl/line__hwg_replay.v
  rtl/line__hwg_requant.v
  rtl/line__hwg_slice.v
  rtl/line__mlp.v
  rtl/line__net_l0.v
  rtl/line__net_l0_bias.v
  rtl/line__net_l0_pe.v
  rtl/line__net_l0_w0.v
} {
  prj_add_source $root/$file
}
prj_add_source $root/constraints/line.sdc
prj_set_impl_opt -impl impl_1 top line
prj_save
prj_run Synthesis -impl impl_1
prj_run Map -impl impl_1
prj_run PAR -impl impl_1
prj_save
prj_close
