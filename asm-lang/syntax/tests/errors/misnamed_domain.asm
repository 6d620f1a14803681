asm misnamed_domain
signature:
  domain speed subsetof Integer //~ L036
  controlled v: speed //~ L036
definitions:
