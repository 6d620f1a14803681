// what a rule wrote is there for the rules after it: the environment does not undo it in the step
asm shared_written_in_seq
import StandardLibrary
signature:
  shared s: Integer
  controlled x: Integer
definitions:
  main rule r_Main = seq
    s := 5
    x := s
  endseq
//? step 1: s = 9
//= step 1: s := 5, x := 5
