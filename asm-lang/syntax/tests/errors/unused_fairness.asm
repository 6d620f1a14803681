asm unused_fairness
signature:
definitions:
  FAIRNESS a //~ L057
  main rule r_Main = skip
