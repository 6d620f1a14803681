asm unused_fairness
signature:
definitions:
  FAIRNESS a //~ L037
  main rule r_Main = skip
