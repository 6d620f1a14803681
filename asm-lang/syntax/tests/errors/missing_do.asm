asm missing_do
signature:
definitions:
  main rule r_Main =
    forall $x in s with $x > 1
      f($x) := 2 //~ L052
