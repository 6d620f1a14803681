asm exponent_huge
signature:
definitions:
  main rule r_Main = a := 1.5E300 //~ L007
