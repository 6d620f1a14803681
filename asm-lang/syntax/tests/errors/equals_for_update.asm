asm equals_for_update
signature:
definitions:
  main rule r_Main =
    par
      a = 1 //~ L050
      b := 2
    endpar
