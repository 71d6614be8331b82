"""t2l: which controller gains make robot learning work, and where a simulator departs from reality."""
