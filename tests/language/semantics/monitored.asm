// the environment owns it
asm monitored
import StandardLibrary
signature:
  monitored m: Integer
  controlled x: Integer
definitions:
  main rule r_Main = x := m
//? step 1: m = 3
//= step 1: x := 3
//? step 2: m = 4
//= step 2: x := 4
