asm errors_in_one_block
signature:
definitions:
  main rule r_Main =
    par
      a = 1 //~ L050
      b := 2
      if a then
        b := * 3 //~ L058
      endif
      forall x in s do skip //~ L056
      c := 4
      d := (5 + 6
      e := 7 //~ L031
    endpar
