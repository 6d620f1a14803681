asm cut_off
signature:
definitions:
  main rule r_Main =
    par
      if a = 1 then //~ L030
