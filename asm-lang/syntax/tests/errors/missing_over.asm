asm missing_over
signature:
definitions:
  invariant inv_a: a > 1 //~ L052
  main rule r_Main = skip
