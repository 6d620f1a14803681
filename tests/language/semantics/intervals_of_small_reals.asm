// the steps of an interval are as exact as they are written
asm intervals_of_small_reals
import StandardLibrary
signature:
  controlled x: Seq(Real)
  controlled y: Seq(Real)
definitions:
  main rule r_Main = par
    x := [0.0 : 0.3, 0.1]
    y := [0.0000000000001 : 0.0000000000003, 0.0000000000001]
  endpar
//= step 1: x := [0.0,0.1,0.2,0.3], y := [1.0E-13,2.0E-13,3.0E-13]
