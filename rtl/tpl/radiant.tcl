# @{ module }@: Lattice Radiant (Nexus), synthesis to routes. Not run by hwgen.
# Run in an empty directory outside of the bundle: radiantc BUNDLE/syn/@{ module }@.radiant.tcl
set root [file normalize [file join [file dirname [info script]] ..]]
prj_create -name @{ module }@ -impl impl_1 -dev @{ part }@ -performance @{ grade }@_High-Performance_1.0V -synthesis synplify
foreach file {
@% for file in sources %@  @{ file }@
@% endfor %@} {
  prj_add_source $root/$file
}
prj_add_source $root/constraints/@{ module }@.sdc
prj_set_impl_opt -impl impl_1 top @{ module }@
prj_save
prj_run Synthesis -impl impl_1
prj_run Map -impl impl_1
prj_run PAR -impl impl_1
prj_save
prj_close
