asm no_rule
signature:
definitions:
  main rule r_Main = if a = 1 then else skip endif //~ L035
