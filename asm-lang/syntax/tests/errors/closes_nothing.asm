asm closes_nothing
signature:
definitions:
  main rule r_Main = a := 1
  endpar //~ L033
