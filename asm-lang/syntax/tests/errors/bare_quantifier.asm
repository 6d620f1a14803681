asm bare_quantifier
signature:
definitions:
  main rule r_Main =
    if a = 1 and exists $x in s with $x = 1 then skip endif //~ L038
