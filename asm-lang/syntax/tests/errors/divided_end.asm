asm divided_end
signature:
definitions:
  main rule r_Main =
    par
      if a = 1 then b := 1 end if //~ L009
      if a = 2 then b := 2 endif
    endpar
