asm unclosed_bracket
signature:
definitions:
  main rule r_Main =
    par
      a := (1 + b * 2
      b := 2 //~ L031
    endpar
