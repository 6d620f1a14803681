asm one_rule_commented
signature:
  controlled a: Integer
definitions:
  main rule r_Main =
    par //~ L072
      // stays
      a := 1
    endpar
