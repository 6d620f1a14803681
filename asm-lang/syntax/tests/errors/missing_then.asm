asm missing_then
signature:
definitions:
  main rule r_Main =
    par
      if a = 1
        b := 2 //~ L052
      endif
      a := 1
    endpar
