// a loop may count in a variable
asm variable_assigned_in_while
import StandardLibrary
signature:
  controlled sum: Integer
definitions:
  main rule r_Main =
    let ($i = 0, $s = 0) in seq
      while $i < 4 do par
        $i := $i + 1
        $s := $s + $i
      endpar
      sum := $s
    endseq endlet
//= step 1: sum := 6
