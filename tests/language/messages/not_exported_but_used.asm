asm not_exported_but_used
import StandardLibrary
import sensors
import arms(grip)
import wheels  //~ W003
signature:
  controlled n: Integer
  controlled side: Side                                      //~ A004
definitions:
  main rule r_Main = par
    n := range + bearing                                     //~ A001
    n := turns                                               //~ A001
    side := LEFT                                             //~ A005
    r_calibrate[]                                            //~ A003
    r_release[]                                              //~ A003
    r_bearing[]                                              //~ A003
  endpar
default init s0:
  function bearing = 3                                       //~ A020
//--- sensors.asm
module sensors
import StandardLibrary
export range, r_reset
signature:
  enum domain Side = {LEFT | RIGHT}
  monitored range: Integer
  controlled bearing: Integer
definitions:
  rule r_reset = skip
  rule r_calibrate = skip
//--- arms.asm
module arms
export *
signature:
  static grip: Integer
definitions:
  function grip = 1
  rule r_release = skip
//--- wheels.asm
module wheels
signature:
  static turns: Integer
definitions:
  function turns = 1
