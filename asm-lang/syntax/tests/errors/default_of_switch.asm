asm default_of_switch
signature:
definitions:
  main rule r_Main =
    switch a
      case 1: b := 2
      default: b := 3 //~ L009
    endswitch
