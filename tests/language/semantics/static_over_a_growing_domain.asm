// a definition that ranges over a domain sees the elements it has now
asm static_over_a_growing_domain
import StandardLibrary
signature:
  abstract domain Order
  static many: Boolean
  controlled x: Boolean
definitions:
  function many = size(Order) > 1
  main rule r_Main = par extend Order with $o do skip  x := many endpar
//= step 1: Order + {order!1}, x := false
//= step 2: Order + {order!2}, x := false
//= step 3: Order + {order!3}, x := true
