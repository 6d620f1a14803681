asm second_main
signature:
definitions:
  main rule r_Main = skip
  main rule r_Other = skip //~ L024
