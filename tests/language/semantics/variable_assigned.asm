// a variable that is assigned is a location of the rule that binds it: in `par` nobody sees the new
// value, in `seq` the rules that follow do, and after the rule it is forgotten
asm variable_assigned
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
definitions:
  main rule r_Main =
    let ($a = 1) in seq
      par
        $a := $a + 1
        x := $a
      endpar
      $a := $a * 10
      y := $a
    endseq endlet
//= step 1: x := 1, y := 20
//= step 2: x := 1, y := 20
