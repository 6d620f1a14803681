asm return_of_no_rule
signature:
definitions:
  main rule r_Main = a <- f(1) //~ L061
