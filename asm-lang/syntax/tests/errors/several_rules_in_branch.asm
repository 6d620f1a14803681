asm several_rules_in_branch
signature:
definitions:
  main rule r_Main =
    if a = 1 then
      a := 2
      b := 3 //~ L034
    endif
