asm exponent
signature:
definitions:
  main rule r_Main = a := 1.5E3 //~ L007
