// a step reads it once, wherever it is first read
asm monitored_once_a_step
import StandardLibrary
signature:
  monitored m: Integer
  controlled x: Integer
  controlled y: Integer
  controlled z: Integer
definitions:
  main rule r_Main = par seq x := 1  y := m endseq  z := m endpar
//? step 1: m = 3
//= step 1: x := 1, y := 3, z := 3
