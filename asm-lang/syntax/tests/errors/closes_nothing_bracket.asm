asm closes_nothing_bracket
signature:
definitions:
  main rule r_Main = a := 1 + 2) * 3 //~ L033
