asm missing_case
signature:
definitions:
  main rule r_Main =
    switch a
      1: b := 2 //~ L052
    endswitch
