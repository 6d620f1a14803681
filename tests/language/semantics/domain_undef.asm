// undef is in every domain
asm domain_undef
import StandardLibrary
signature:
  domain Small subsetof Integer
  controlled x: Small
definitions:
  domain Small = {1 : 3}
  main rule r_Main = x := undef
//= step 1: x := undef
