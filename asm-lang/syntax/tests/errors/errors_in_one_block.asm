asm errors_in_one_block
signature:
definitions:
  main rule r_Main =
    par
      a = 1 //~ L030
      b := 2
      if a then
        b := * 3 //~ L038
      endif
      forall x in s do skip //~ L036
      c := 4
      d := (5 + 6
      e := 7 //~ L021
    endpar
