asm missing_variable
signature:
definitions:
  main rule r_Main = extend D with $x, do skip //~ L058
