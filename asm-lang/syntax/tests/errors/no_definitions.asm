asm no_definitions
signature:
  main rule r_Main = skip //~ L074
