asm empty_domain
import StandardLibrary
signature:
  domain Small subsetof Integer  //~ W004
  controlled x: Small
definitions:
  main rule r_Main = skip
