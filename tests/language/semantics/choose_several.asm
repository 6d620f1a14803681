// candidates are the tuples that satisfy the guard
asm choose_several
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
definitions:
  main rule r_Main = choose $a in {1 : 3}, $b in {1 : 3} with $a > $b do par x := $a  y := $b endpar
//? step 1: choose 2
//= step 1: x := 3, y := 2
