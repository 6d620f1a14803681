asm filename  //~ W002
signature:
definitions:
  main rule r_Main = skip
