asm invariant_broken
import StandardLibrary
signature:
  controlled doors: Integer
  controlled moving: Boolean
definitions:
  invariant inv_safe over doors, moving: moving implies doors = 0  //~ R014
  main rule r_Main = par moving := true  doors := doors + 1 endpar
default init s0:
  function doors = 0
  function moving = false
