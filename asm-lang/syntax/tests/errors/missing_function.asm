asm missing_function
signature:
definitions:
  main rule r_Main = skip
default init s0:
  a = 1 //~ L052
  function b = 2
