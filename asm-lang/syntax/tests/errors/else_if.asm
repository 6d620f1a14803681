asm else_if
signature:
definitions:
  main rule r_Main =
    par
      if a = 1 then b := 1
      else if a = 2 then b := 2
      else b := 3
      endif
    endpar //~ L032
