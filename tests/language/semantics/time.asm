// the clock is the time of the step
asm time
import StandardLibrary
import TimeLibrary
signature:
  controlled s: Integer
  controlled n: Integer
definitions:
  main rule r_Main = par s := mCurrTimeSecs  n := mCurrTimeMillisecs endpar
//? step 1: time 61500000000
//= step 1: n := 61500, s := 61
//? step 2: mCurrTimeSecs = 5
//= step 2: n := 0, s := 5
