// `result` belongs to the call: nobody sees that of another one, not within `seq`, not of a rule value
asm turbo_result_hidden
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
  controlled z: Any
  controlled act: Rule
definitions:
  turbo rule r_one in Integer = result := 1
  turbo rule r_nothing in Integer = z := result
  turbo rule r_two in Integer = seq
    result := 2
    x <- r_one()
    r_nothing()
  endseq
  main rule r_Main = par
    y <- r_two()
    act
  endpar
default init s0:
  function z = 5
  function act = <<r_one>>
//= step 1: x := 1, y := 2, z := undef
