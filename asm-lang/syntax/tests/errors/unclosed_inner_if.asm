asm unclosed_inner_if
signature:
definitions:
  main rule r_Main =
    par
      if a = 1 then
        if b = 1 then
          a := 2
      endif
      b := 2
    endpar //~ L031
