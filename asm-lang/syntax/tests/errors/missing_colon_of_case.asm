asm missing_colon_of_case
signature:
definitions:
  main rule r_Main =
    switch a
      case 1 b := 2 //~ L052
      case 2: b := 3
    endswitch
