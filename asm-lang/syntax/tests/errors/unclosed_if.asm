asm unclosed_if
signature:
definitions:
  main rule r_Main =
    par
      if a = 1 then
        b := 2
      a := 2
    endpar //~ L031
